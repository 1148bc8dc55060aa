"""What touches hardware, each behind one small contract, and fakes of exactly those chips and pins."""
