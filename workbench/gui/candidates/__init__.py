"""The tab that shows every grasp that was judged."""
