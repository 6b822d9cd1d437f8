"""The concealed benchmark as a contest that any tool can take part in (docs/benchmark.md)."""
