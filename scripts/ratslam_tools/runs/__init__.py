"""Starting ratslam_run, its result files, and figures of them."""
