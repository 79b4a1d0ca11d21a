"""Closed-form theories that a simulation is compared with.

`janssen`: silos with vertical walls, plane or round. `walker`: hoppers, wedge or cone. `eurocode`: wall pressures after
EN 1991-4:2006. `beverloo`: the rate of discharge.
"""
