"""What users read about the models: the catalogue, reference pages, the grammar; all made from declarations."""
