"""What tests of other packages can use: checks of policies and backends, random scenarios, strategies."""
