"""Installs with catkin or, without ROS, with pip. All other settings are in setup.cfg."""
from setuptools import find_packages, setup

setup(name='file_replacement', version='1.1.0', packages=find_packages('src'),
      package_dir={'': 'src'})
