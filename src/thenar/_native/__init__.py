"""C++20 kernels over int arrays."""
