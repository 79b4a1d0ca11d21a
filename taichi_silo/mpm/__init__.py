"""The material point method: points, grid, shapes, laws, walls, and the solver of a step."""
