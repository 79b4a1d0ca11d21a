"""What a user gives: silo, sand, walls, grid, filling, flow, method, output, machine."""
