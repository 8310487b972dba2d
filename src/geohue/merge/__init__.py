"""Beyond the paper: regions merged on all the evidence, and limbs where clouds branch."""
