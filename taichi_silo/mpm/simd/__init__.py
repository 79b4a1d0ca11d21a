"""Eight points at once on a processor's vector unit: all that knows of groups of eight stands here.

`vectors` what a group is, `lane_maths` elementary functions of a number or of eight, `executor` who steps groups,
`selftest` whether that can be trusted on this machine, by the `trial` that it runs in a process of its own.
"""
