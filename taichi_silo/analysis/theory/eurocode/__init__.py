"""Actions on silos after EN 1991-4:2006.

`solids`: characteristic values. `vertical_walls`: symmetrical pressures. `patch_loads`: what is added for
lack of symmetry. `flow_channel`: outlets far from the axis. `bottoms`: floors and hoppers. `flow_pattern`: mass or
funnel flow. `load_cases`: all of it by depth and angle, and the envelope.

Numbers of equations are given where a public program names them too; the others, and what is called "not confirmed",
were not compared with the printed standard.
"""
