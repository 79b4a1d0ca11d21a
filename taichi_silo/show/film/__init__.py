"""Films and pictures of a run, drawn from the states that it keeps."""


class FilmError(RuntimeError):
    """No film can be encoded: ffmpeg is not there, or has stopped."""
