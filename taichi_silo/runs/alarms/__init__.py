"""What shows that a run has gone wrong, or is about to: each kind of wrongness is one class with a limit.

A check is an observer's smaller sister: `begin(simulation)`, then `look(record)` after each interval, or now and then
`look(record, points)` with the states of all points; both return an `Alarm` or None. `state` and `restore` carry it
over a break of the run. `observers/guard.py` runs them all.
"""
