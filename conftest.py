"""What all unit tests share: how many examples hypothesis tries, and that none has a deadline, for
a loaded machine is no defect.

HYPOTHESIS_PROFILE=compatibility tries a fifth: for a second Python version, under which the tests
look for what does not work there at all.
"""
import os

from hypothesis import HealthCheck, settings

settings.register_profile('project', deadline=None, max_examples=100)
settings.register_profile('compatibility', deadline=None, max_examples=20,
                          suppress_health_check=[HealthCheck.data_too_large])
settings.load_profile(os.environ.get('HYPOTHESIS_PROFILE', 'project'))

collect_ignore = ['src/multimaster_fkie']     # not ours, and its tests need a ROS master
