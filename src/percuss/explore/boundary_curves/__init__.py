"""The boundaries of steady motions in a plane of two parameters, solved for as roots."""
