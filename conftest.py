"""What all unit tests share: how many examples hypothesis tries, and that none has a deadline, for
a loaded machine is no defect.

The same ones in every run, so that a change is judged by nothing but itself; many, and others each
time, with LD90_LONG_TESTS=1 (scripts/test.sh --long). With HYPOTHESIS_PROFILE=compatibility the
fewest of which every property's share is an example: for a second Python version, under which the
tests look for what does not work there at all.
"""
import os

from hypothesis import HealthCheck, settings

LONG = os.environ.get('LD90_LONG_TESTS') == '1'

settings.register_profile('project', deadline=None, max_examples=500 if LONG else 60,
                          derandomize=not LONG)
settings.register_profile('compatibility', deadline=None, max_examples=7, derandomize=True,
                          suppress_health_check=[HealthCheck.data_too_large])
settings.load_profile(os.environ.get('HYPOTHESIS_PROFILE', 'project'))

collect_ignore = ['src/multimaster_fkie']     # not ours, and its tests need a ROS master
