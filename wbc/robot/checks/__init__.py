"""The model doctor's examinations: each file looks for one kind of defect."""
