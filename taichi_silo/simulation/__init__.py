"""From a scene to its history: discretise, fill, settle, flow, record."""
