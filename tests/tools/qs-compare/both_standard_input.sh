qs-compare - -
