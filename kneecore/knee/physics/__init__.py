"""The knee's mechanics as compiled kernels on flat rows of constants."""
