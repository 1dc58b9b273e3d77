// Runs the notebook named in the page's address as soon as its kernel is there. JupyterLab has no
// setting for that. It loads this as one of its prebuilt extensions: a container with init and get.

const path = () => JSON.parse(document.getElementById("jupyter-config-data").textContent).treePath;

const opened = app =>
  new Promise(found => {
    const look = setInterval(() => {
      for (const one of app.shell.widgets("main")) {
        if (one.sessionContext && one.context && one.context.path === path()) {
          clearInterval(look);
          found(one);
        }
      }
    }, 100);
  });

const plugin = {
  id: "tvclin-explore:run",
  autoStart: true,
  activate: app => {
    const run = async () => {
      const notebook = await opened(app);
      await Promise.all([notebook.context.ready, notebook.sessionContext.ready]);
      app.shell.activateById(notebook.id);
      if (app.shell.collapseLeft) {
        app.shell.collapseLeft(); // room for the panel
      }
      await app.commands.execute("notebook:run-all-cells");
    };
    if (path()) {
      app.restored.then(run);
    }
  }
};

(window._JUPYTERLAB = window._JUPYTERLAB || {})["tvclin-explore"] = {
  init: () => {},
  get: async () => () => ({ __esModule: true, default: plugin })
};
