"""Installs with catkin and, without ROS, with pip: the rest stands in setup.cfg."""
from setuptools import find_packages, setup

setup(name='route_protocol', version='1.1.0', packages=find_packages('src'),
      package_dir={'': 'src'})
