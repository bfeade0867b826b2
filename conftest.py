"""What all unit tests share: examples of hypothesis have no deadline, for a loaded machine is no
defect."""
from hypothesis import settings

settings.register_profile('project', deadline=None)
settings.load_profile('project')

collect_ignore = ['src/multimaster_fkie']     # not ours, and its tests need a ROS master
