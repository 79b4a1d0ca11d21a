"""One file, one command of `taichi-silo`, and a function of the same name in it; heavy imports stay inside of it."""
