"""What runs the robot: jobs, planner, controller, daemon, command line."""
