"""Imported by workers at their start: Ctrl-C is for whoever leads the sweep, who then asks the workers to stop."""

import signal
import threading

if threading.current_thread() is threading.main_thread():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
