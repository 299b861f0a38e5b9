"""Pictures of one kind each; :class:`directrix.plot.Plots` and :meth:`directrix.Modes.plot` lead here."""
