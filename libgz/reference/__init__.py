"""Reference for users, generated from declarations: the catalogue of models, pages, the grammar, and the checker."""
