"""What this project is built on: checked against its lock."""
