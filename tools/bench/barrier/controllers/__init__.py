"""The programs that are compared, one module each. A module imports its library only when it is made."""
