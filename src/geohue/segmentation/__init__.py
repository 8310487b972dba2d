"""The driver of the method, its settings, its choice of K and the weight, and its result."""
