"""A robot that `ros2_control` drives, as hardware."""
