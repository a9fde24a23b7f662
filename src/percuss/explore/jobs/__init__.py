"""Running jobs: in this process, in others or on a cluster, kept in an archive, interrupted and resumed."""
