"""Many runs: comparisons, benchmarks, batches, and the registration of files."""
