"""Studies of the method by this project: the paper, stability, accuracy, biaxial compression."""
