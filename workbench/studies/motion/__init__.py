"""Motion problems from files; both arms as one."""
