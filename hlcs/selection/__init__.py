"""Which effect is missing: candidates, search, competing models, verdict, the next experiment."""
