"""The rules by which a run finds state events and carries out samples.

They are those of the run of a simulation and of the FMU core alike: its C text takes these numbers, under these names
behind RULE_, from the tables of each exported model.
"""

STRETCH = 400  # output points at most of a stretch, whose times are reckoned from its start
SUBSTEPS = 4  # points per output step at which the indicators of state events are looked at
ROUNDS = 50  # times that events at one instant may set off others
CHATTER = 20  # times that an event may return at once, before it is taken for one without an end
AT_ONCE = 1e-6  # of a substep: time within which an event returns at once
AHEAD = 1e-3  # of a substep: how far it is looked ahead to see whether an indicator rises
HALVINGS = 40  # of an interval, in search of the place where an indicator that was zero has risen
INSTANT = 1e-13  # relative to the time, or of 1 s: accuracy of the instant of an event
TOGETHER = 1e-12  # relative to the time until the first: events that are carried out with it
DUE = 1e-9  # of a period: time by which a sample may be early
TINY = 1e-7  # of an output step: distance within which two instants are the same
REACHES = (0.0, 1e-9, 1e-6, 1e-4, 1e-2, 0.1, 0.3, 1.0)  # output steps ahead at which the cause of a failure is sought
RATE_FLOOR = 1e-6  # of a state: added to its size, to compare how fast states change
