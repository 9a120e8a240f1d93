"""What a run of ratslam_run leaves behind, its pictures, and starting a run."""
