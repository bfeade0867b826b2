"""Installs with catkin and, without ROS, with pip. setup.cfg has the other settings."""
from setuptools import find_packages, setup

setup(name='omron_map_converter', version='1.1.0',
      packages=find_packages('src'), package_dir={'': 'src'})
