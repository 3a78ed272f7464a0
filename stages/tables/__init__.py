"""Tables 2 and 3, Figures 4, 6 and 9, and the report page: the only stage that aggregates rows."""
