"""What exists, as data: the course, the arena, the robot, looks, scenarios, frames."""
