"""Uncertainty of the velocity case by the law of propagation (GUM), and beside Monte Carlo."""

from mcsim.gum.budget import Budget, BudgetRow, step_budget
from mcsim.gum.course import Course, course_of_uncertainty

__all__ = ["Budget", "BudgetRow", "Course", "course_of_uncertainty", "step_budget"]
