"""The file of a case: what it may say, how it is read and written, and the objects of the model that it stands for."""
