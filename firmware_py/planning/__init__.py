"""Planning outside the daemon's interpreter: a job file goes in, a plan that may run comes out."""
