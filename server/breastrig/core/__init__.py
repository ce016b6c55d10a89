"""Words that every floor uses: errors, array types, units, the notice of limits of use."""
