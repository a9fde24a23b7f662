"""Jobs carried out: by this process, by others or by a cluster, kept in an archive, interrupted and resumed."""
