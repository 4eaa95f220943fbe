"""What holds for all tests."""

from hypothesis import settings

# How long an example takes depends on the machine and on what must be compiled first.
settings.register_profile('tauto', deadline=None)
settings.load_profile('tauto')
