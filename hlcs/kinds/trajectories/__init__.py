"""Recordings of a body's motion."""

from hlcs.kinds.trajectories.experiment import Trajectories
