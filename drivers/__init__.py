"""What touches hardware, each behind a small contract, and fakes of just those chips and pins."""
