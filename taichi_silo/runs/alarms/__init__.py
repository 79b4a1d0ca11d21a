"""What shows that a run has gone wrong, or is about to: each kind of wrongness is one class with a limit.

A check is made for a simulation; `look(record)` after each interval, or now and then `look(record, points)` with the
states of all points, returns an `Alarm` or None. `state` and `restore` carry it over a break of the run.
`observers/guard.py` runs them all.
"""
