from setuptools import find_packages, setup

setup(name='graph_fleet_manager', version='1.1.0',
      packages=find_packages('src'), package_dir={'': 'src'})
