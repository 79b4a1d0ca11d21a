"""The two ways in which a run says no."""


class BadInput(ValueError):
    """What the user asked for is not possible; nothing has been done or written."""


class RunFailed(RuntimeError):
    """The run went wrong; everything up to then is kept."""
