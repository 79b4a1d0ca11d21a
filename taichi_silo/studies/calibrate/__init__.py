"""Constants of the law from laboratory tests: read, guessed by closed formulas, fitted, and how far they are known."""
