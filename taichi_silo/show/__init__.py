"""What a run looks like: film, figures, report, export, gallery."""
