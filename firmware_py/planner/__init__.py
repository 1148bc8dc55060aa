"""From a job to ticks: path, inverse kinematics, counts, limits along the whole path, timing."""
