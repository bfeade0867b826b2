"""Installs with catkin and, without ROS, with pip. setup.cfg has the other settings."""
from setuptools import find_packages, setup

setup(name='omron_ld90_sim', version='1.1.0', packages=find_packages('src'),
      package_dir={'': 'src'})
