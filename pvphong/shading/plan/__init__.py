"""Which effects a scene needs, one file each."""
