MODULE Operator
    ! Operator: what RobotWare knows, never run.
    VAR num n;
    VAR errnum e;
    VAR btnres r;
    VAR listitem items{2}:=[["","a"],["","b"]];

    PROC main()
        TPReadNum n,"how many"\MaxTime:=5\DIBreak:=diX\BreakFlag:=e;
        r:=UIMessageBox(\Header:="a"\MsgArray:=["b","c"]\BtnArray:=["d","e"]\Icon:=iconInfo);
        n:=UIListView(\Result:=r\Header:="x",items\Buttons:=btnOKCancel\Icon:=iconWarning);
        n:=UINumEntry(\Header:="x"\Message:="y"\InitValue:=5\AsInteger);
        UIMsgBox "x"\MsgLine2:="y"\Buttons:=btnYesNo\Result:=r;
        ErrWrite\W,"a","b"\RL2:="c";
        TEST OpMode()
        CASE OP_AUTO:
            ExitCycle;
        CASE OP_MAN_PROG,OP_MAN_TEST:
            Stop\NoRegain;
        ENDTEST
        IF e=ERR_TP_MAXTIME OR r=resYes TPShow TP_LATEST;
    ENDPROC
ENDMODULE
